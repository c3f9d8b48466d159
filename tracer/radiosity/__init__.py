"""Radiosity whose rays are sent where the view from a patch is complex (the paper, section 4.2)."""
