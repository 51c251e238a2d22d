"""URDF files as MuJoCo's spec, as V-REP's importer reads them."""
