"""Windows made from XML, as those of `simUI`: their text, what programs set and read, and what people do to them."""
