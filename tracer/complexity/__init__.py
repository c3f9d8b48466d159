"""What cheap rays hit, and measures of how complex it is."""
