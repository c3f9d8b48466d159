"""What cheap rays hit, and how complex that is."""
