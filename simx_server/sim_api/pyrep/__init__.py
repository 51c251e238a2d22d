"""The functions of PyRep's add-on, which its Python classes call for planned paths and a few more."""
