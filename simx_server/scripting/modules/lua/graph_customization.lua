-- The customization of a graph: in CoppeliaSim it draws the graph's window and a dialog of its settings, and lets a
-- script record whenever it likes.
--
-- The web viewer draws graphs, so what only concerns the window does nothing here.

sim.addLog(
    sim.verbosity_scriptinfos + sim.verbosity_once,
    "graphs open no window: the web viewer draws them (--view)"
)

local graph = {}

-- From here on the graph records only what `handle` is called for.
function graph.init()
    graph.model = sim.getObject(".")
    if sim.getObjectType(graph.model) == sim.sceneobject_script then graph.model = sim.getObject("..") end
    sim.setExplicitHandling(graph.model, 1)
end

function graph.handle(time)
    sim.handleGraph(graph.model, time or sim.getSimulationTime() + sim.getSimulationTimeStep())
end

function graph.reset() sim.resetGraph(graph.model) end

graph.beforeSimulation = graph.reset

local of_the_window = {
    "afterSimulation", "cleanup", "clearCurves", "createOrRemovePlotIfNeeded", "createPlot", "enableMouseInteractions",
    "prepareCurves", "refresh", "remove3dCurves", "removeDlg", "removePlot", "setDlgItemContent", "updateCurves",
}
for _, name in ipairs(of_the_window) do graph[name] = function() end end

return graph
