-- Copies of tables, with the tables within them or without.

return { copy = table.clone, deepcopy = table.deepcopy }
