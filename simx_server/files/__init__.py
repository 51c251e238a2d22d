"""Files: the workspace where clients may write, regular files, image files, shipped scenes."""
