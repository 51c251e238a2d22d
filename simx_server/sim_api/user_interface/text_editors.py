"""Windows with a text that people edit, and entries of a menu, in the web viewer."""

from __future__ import annotations

from simx_server.parts.user_interface.contents.text_editors import TEXT_ID, TextEditor, read_editor
from simx_server.parts.user_interface.menu import DESTROY, KEEP, MenuEntry
from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.targets import split_target
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_NEW = -1


class TextEditorFunctions(ApiPart, effect="changes"):
    """Functions for text editors and for the menu of modules."""

    def textEditorOpen(self, text: str = "", properties: str = "") -> int:
        """Open a window with a text and return its handle; web viewers show it, and people edit the text. `properties`:
        XML, <editor title="..." editable="true" on-close="function" .../>. The function is called when a person has
        closed the editor; its text can be read until sim.textEditorClose. Colours, fonts and words that are completed
        are the browser's.
        """
        editor = read_editor(text, properties)
        interpreter = self._script.interpreter
        if interpreter is not None:
            editor.is_alive = lambda: self._script.interpreter is interpreter
        editor.fire = lambda function, _values: self._run(function)
        return self._world.user_interface.windows.add(editor)[0]

    def textEditorShow(self, handle: int, show: bool) -> int:
        """Show or hide a text editor and return 1."""
        self._editor(handle).is_visible = show
        return 1

    def textEditorClose(self, handle: int) -> tuple[str, list[int], list[int]]:
        """Close a text editor and return its text, position and size (pixels)."""
        editor = self._editor(handle)
        self._world.user_interface.windows.remove(handle)
        return editor.widgets[TEXT_ID].text, list(editor.position), list(editor.size)

    @reads
    def textEditorGetInfo(self, handle: int) -> tuple[str, list[int], list[int], bool] | None:
        """Return text, position and size (pixels), and whether it is shown; nil for an editor that is closed."""
        windows = self._world.user_interface.windows
        windows.forget_the_gone()
        if handle not in windows:
            return None
        editor = self._editor(handle)
        return editor.widgets[TEXT_ID].text, list(editor.position), list(editor.size), editor.is_visible

    closeTextEditor = textEditorClose

    def openTextEditor(
        self, text: str, properties: str | None = None, callback: str | None = None
    ) -> int | str:
        """Open a text editor and return its handle. Without a function to call at its end, V-REP waited until it was
        closed. Partly: the text is returned as it is then.
        """
        if callback is None:
            self._say_once(
                "sim.openTextEditor returns the text as it is: give it a function to call at the end"
            )
            return text
        handle = self.textEditorOpen(text, properties or "")
        self._editor(handle).events["on-close"] = callback
        return handle

    def moduleEntry(self, handle: int, label: str | None = None, state: int = KEEP) -> int:
        """Create an entry of the menu of modules (handle -1), change it, or remove it (state -2); return its handle.
        Web viewers show the menu; a click calls the script's sysCall_moduleEntry({handle = ...}). `label`: in front of
        that of a new entry stand names of menus, each on a line. `state`: 1 enabled, 2 checked, 4 checkable, -1 as it
        was.
        """
        menu = self._world.user_interface.menu
        if handle == _NEW:
            interpreter, script = self._script.interpreter, self._script
            entry = MenuEntry(label or "", select=self._select)
            if interpreter is not None:
                entry.is_alive = lambda: script.interpreter is interpreter
            handle = menu.add(entry)[0]
        elif label is not None:
            menu.get(handle).title = label
        if state == DESTROY:
            menu.remove(handle)
        elif state != KEEP:
            menu.get(handle).state = state
        return handle

    def refreshDialogs(self, _degree: int = 0) -> int:
        """Return 1: all windows show the present values, since web viewers read them several times a second."""
        return 1

    def _select(self, entry: int) -> None:
        interpreter = self._script.interpreter
        if interpreter is not None and interpreter.has("sysCall_moduleEntry"):
            self._run("sysCall_moduleEntry", {"handle": entry})

    def _run(self, function: str, *values: object) -> None:
        """Call a function of the script; an error is printed."""
        name, _ = split_target(function, "")
        try:
            self._world.scripts.run(self._script, name, *values)
        except ScriptError as problem:
            self._world.status_bar.add(str(problem))

    def _editor(self, handle: int) -> TextEditor:
        found = self._world.user_interface.windows.get(handle)
        if not isinstance(found, TextEditor):
            raise ScriptError(f"window {handle} ('{found.title}') is not a text editor")
        return found
