"""The bundled scenes."""
