"""Windows with a text that people edit, described by `sim.textEditorOpen`."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

from simx_server.errors import CommandError

from ..widgets import MAX_TEXT, Widget
from ..xml_windows.reading import MAX_XML, switch, two_numbers
from ..xml_windows.well_formed import well_formed
from ..xml_windows.windows import XmlWindow

TEXT_ID = 1
"""Id of the text."""


@dataclass(eq=False)
class TextEditor(XmlWindow):
    """One editor."""

    is_modal: bool = False
    """It opens above the scene, as a dialog does."""

    def close(self) -> None:
        """Close it as its user does: it is hidden, and the script is called, which reads its text."""
        if not self.is_closeable:
            raise CommandError(f"text editor {self.handle} ('{self.title}') cannot be closed by its user")
        self.is_visible = False
        function = self.events.get("on-close")
        if function is None:
            self.is_alive = lambda: False
        else:
            self.fire(function, ())


def read_editor(text: str, xml: str) -> TextEditor:
    """Return an editor with a text and the properties that XML describes; empty for the usual ones.

    Raises:
        CommandError: it is not XML of an editor, or too large.
    """
    if len(xml) > MAX_XML:
        raise CommandError(f"the XML of a text editor has {len(xml)} characters; at most {MAX_XML}")
    try:
        root = ElementTree.fromstring(well_formed(xml)) if xml.strip() else ElementTree.Element("editor")
    except (ElementTree.ParseError, ValueError, LookupError) as problem:
        raise CommandError(f"the XML of the text editor cannot be read: {problem}") from None
    if root.tag != "editor":
        raise CommandError(f"the XML of a text editor must begin with <editor>, not <{str(root.tag)[:40]}>")
    function = root.get("on-close", "")
    editor = TextEditor(
        title=root.get("title", "Text editor")[:MAX_TEXT],
        is_closeable=switch(root, "closeable", default=True),
        events={"on-close": function[:MAX_TEXT]} if function else {},
        position=two_numbers(root, "position", (100, 100)),
        size=two_numbers(root, "size", (800, 600)),
        is_modal=switch(root, "modal", default=False),
    )
    is_read_only = not switch(root, "editable", default=True)
    editor.widgets[TEXT_ID] = Widget(TEXT_ID, "text-browser", text=text[:MAX_TEXT], is_read_only=is_read_only)
    return editor
