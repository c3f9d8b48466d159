"""What guided rays are worth in radiosity."""
