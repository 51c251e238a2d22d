"""Graphs: streams of numbers that are recorded over simulated time, and curves that plot streams against each other.

V-REP's graphs are separate objects; here any object, such as a dummy of that name, can represent one. A value that is
set is recorded when the graph is handled: at the end of each simulation step, or earlier by a script. Streams of the
scene's file (`simx:graph:NAME`) measure their values themselves. The data of a run stay until the next run starts.
"""

from .graphs import Graphs
from .streams import CUMULATIVE, Color, Curve, Graph, Stream, span

__all__ = ["CUMULATIVE", "Color", "Curve", "Graph", "Graphs", "Stream", "span"]
