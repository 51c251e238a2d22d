"""Names of objects: the rules of names, paths of objects, and names like a wrong one."""
