"""Radiosity with rays that go where what a patch sees is complex (the paper, section 4.2)."""
