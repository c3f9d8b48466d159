"""By which factor the variance could fall if lights, directions and lengths of paths were chosen at best."""
