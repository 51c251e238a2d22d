"""The user interface of programs: status bar, consoles, dialogs, custom UIs, windows made from XML."""
