"""What is claimed of views: how fast they are measured, how good the searches and estimates are."""
