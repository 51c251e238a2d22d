"""Values between scripts and the server: arguments of functions, results of call-backs, texts and bytes."""
