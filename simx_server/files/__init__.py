"""Files: finding scenes, checking what they name, and the workspace where clients may write."""
