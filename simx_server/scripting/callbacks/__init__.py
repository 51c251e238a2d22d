"""Scripts that physics or cameras call, and scripts that wait for an image."""
