"""A class: a server for each student, a page that shows all of them, and a token for each seat (docs/classroom.md)."""
