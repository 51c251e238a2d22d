"""Commands of ``simx`` that the installed server implements."""
