"""Files: search for scenes, check what they reference, and the workspace where clients may write."""
