"""Constants of API 2 that programs use."""

handle_app, handle_scene, handle_self, handle_all, handle_world = -13, -12, -4, -2, -1

propertytype_bool, propertytype_int, propertytype_float, propertytype_string, propertytype_buffer = range(5)
propertytype_vector3, propertytype_quaternion, propertytype_pose = 5, 6, 7
propertytype_color3, propertytype_floatarray, propertytype_table, propertytype_intarray = 10, 11, 12, 13
propertytype_intarray2, propertytype_long, propertytype_null, propertytype_matrix = 15, 16, 17, 18
propertytype_array, propertytype_map, propertytype_handle, propertytype_handlearray = 19, 20, 21, 22
propertytype_stringarray, propertytype_group, propertytype_enum, propertytype_color = 23, 24, 25, 26
propertytype_object, propertytype_objectarray, propertytype_objectmap, propertytype_method = (
    224,
    225,
    226,
    240,
)

propertyinfo_notwritable, propertyinfo_notreadable, propertyinfo_removable = 1, 2, 4
propertyinfo_modelhashexclude, propertyinfo_deprecated, propertyinfo_silent = 8, 16, 32
propertyinfo_constant, propertyinfo_largedata = 64, 256
