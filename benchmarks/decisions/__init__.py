"""What adaptive renders decide, shown on one scene each."""
