"""The style of the page beside viser's: sizes of type and buttons, and where the panel is in narrow windows.

viser has no settings for these. Its elements are found by their inline styles, of which a test with a browser tells if
they change.
"""

from __future__ import annotations

PANEL_WIDTH = 464
"""Width of the docked panel in pixels, as long as `PAGE_STYLE` does not make it a share of the window."""

_DOCKED = f"width: {PANEL_WIDTH + 4}px"
"""The style of a docked panel with its borders, until a user drags its edge: then it has another width."""

_PANEL = f'div[style*="right: 0px"][style*="{_DOCKED}"]'
_CANVAS = f'div[style*="inset: 0px {PANEL_WIDTH + 4}px 0px 0px"]'
"""The element of the 3-D view beside a docked panel."""

_SHARE = "clamp(400px, 36.25%, 576px)"

_SHEET = '.mantine-Paper-root[style*="position: fixed"][style*="bottom: 0"]'
"""viser's panel in narrow windows."""

_SMALL_BUTTON = '.mantine-Button-root[data-size="compact-xs"]'
_LABEL = 'p[style*="letter-spacing: -0.75px"]'

PAGE_STYLE = f"""<style>
.mantine-ScrollArea-content {{ padding-right: 0.6em; }}
.mantine-ScrollArea-content .mantine-ScrollArea-content {{ padding-right: 0; }}
[role=tablist] {{ flex-wrap: nowrap !important; overflow-x: auto; scrollbar-width: none; }}
[role=tab] {{ padding-left: 0 !important; padding-right: 0 !important; flex: 1 1 auto !important; min-width: 0;
  white-space: nowrap; letter-spacing: -0.02em; justify-content: center; text-align: center; }}
{_LABEL} {{ letter-spacing: normal !important; color: var(--mantine-color-text) !important; opacity: 0.8; }}
{_SMALL_BUTTON} {{ font-size: 13px; height: 25px; padding-left: 6px; padding-right: 6px; }}
.simx-brief {{ display: none; }}
{_PANEL} {{ width: {_SHARE} !important; }}
{_PANEL} div[style*="{_DOCKED}"] {{ width: 100% !important; }}
{_CANVAS} {{ right: {_SHARE} !important; }}
@media (max-height: 800px), (max-width: 36em), (max-width: 62em) and (orientation: portrait) {{
  .simx-long {{ display: none; }}
  .simx-brief {{ display: block; }}
}}
@media (min-width: 36.01em) and (max-width: 62em) and (orientation: portrait) {{
  {_PANEL} {{ width: 100% !important; top: 52% !important; }}
  {_CANVAS} {{ right: 0 !important; bottom: 48% !important; }}
}}
@media (pointer: coarse), (max-width: 36em) {{
  {_SMALL_BUTTON} {{ font-size: 14px; height: 34px; }}
  [role=tab] {{ font-size: 14px; min-height: 36px; }}
  .mantine-Button-root {{ font-size: 14px; }}
  {_LABEL} {{ font-size: 13px !important; }}
}}
@media (max-width: 36em) {{
  {_SHEET} {{ left: 0 !important; width: 100% !important; max-height: 50% !important; }}
  {_SHEET} div[style*="width: 20em"] {{ width: 100% !important; }}
  body:has({_SHEET} div[style*="width: 20em"] > div > div[style*="grid-template-rows: 1fr"])
    div[style*="inset: 0px"]:has(> canvas) {{ bottom: 50% !important; }}
}}
</style>"""
"""Space for the scroll bar, which viser draws over the right edge; all tabs in one row; labels that can be read; the
docked panel's share of the window. On an upright tablet the panel is below the view, and in narrow windows a sheet as
wide as the window. Low windows have brief texts; fingers have larger buttons.
"""
