"""The constants of the official binding that the functions of this package need.

The source of the values is simConst.h of the simulator's maker.
"""

from __future__ import annotations

simx_opmode_oneshot = 0x000000
simx_opmode_blocking = simx_opmode_oneshot_wait = 0x010000
simx_opmode_streaming = simx_opmode_continuous = 0x020000
simx_opmode_oneshot_split = 0x030000
simx_opmode_streaming_split = simx_opmode_continuous_split = 0x040000
simx_opmode_discontinue = 0x050000
simx_opmode_buffer = 0x060000
simx_opmode_remove = 0x070000

simx_return_ok = simx_error_noerror = 0x00
simx_return_novalue_flag = simx_error_novalue_flag = 0x01
simx_return_timeout_flag = simx_error_timeout_flag = 0x02
simx_return_illegal_opmode_flag = simx_error_illegal_opmode_flag = 0x04
simx_return_remote_error_flag = simx_error_remote_error_flag = 0x08
simx_return_split_progress_flag = simx_error_split_progress_flag = 0x10
simx_return_local_error_flag = simx_error_local_error_flag = 0x20
simx_return_initialize_error_flag = simx_error_initialize_error_flag = 0x40

simx_headeroffset_crc = 0
simx_headeroffset_version = 2
simx_headeroffset_message_id = 3
simx_headeroffset_client_time = 7
simx_headeroffset_server_time = 11
simx_headeroffset_scene_id = 15
simx_headeroffset_server_state = 17

sim_object_shape_type = 0
sim_object_joint_type = 1
sim_object_graph_type = 2
sim_object_camera_type = 3
sim_object_dummy_type = 4
sim_object_proximitysensor_type = 5
sim_object_path_type = 8
sim_object_visionsensor_type = 9
sim_object_volume_type = 10
sim_object_mill_type = 11
sim_object_forcesensor_type = 12
sim_object_light_type = 13
sim_object_mirror_type = 14

sim_handle_all = -2
sim_handle_all_except_explicit = -3
sim_handle_self = -4
sim_handle_main_script = -5
sim_handle_tree = -6
sim_handle_chain = -7
sim_handle_single = -8
sim_handle_default = -9
sim_handle_all_except_self = -10
sim_handle_parent = -11

sim_simulation_stopped = 0
sim_simulation_paused = 0x8
sim_simulation_advancing = 0x10
sim_simulation_advancing_firstafterstop = 0x10
sim_simulation_advancing_running = 0x11
sim_simulation_advancing_lastbeforepause = 0x13
sim_simulation_advancing_firstafterpause = 0x14
sim_simulation_advancing_abouttostop = 0x15
sim_simulation_advancing_lastbeforestop = 0x16

sim_joint_revolute_subtype = 10
sim_joint_prismatic_subtype = 11
sim_joint_spherical_subtype = 12

sim_boolparam_hierarchy_visible = 0
sim_boolparam_console_visible = 1
sim_boolparam_collision_handling_enabled = 2
sim_boolparam_distance_handling_enabled = 3
sim_boolparam_ik_handling_enabled = 4
sim_boolparam_gcs_handling_enabled = 5
sim_boolparam_dynamics_handling_enabled = 6
sim_boolparam_joint_motion_handling_enabled = 7
sim_boolparam_path_motion_handling_enabled = 8
sim_boolparam_proximity_sensor_handling_enabled = 9
sim_boolparam_vision_sensor_handling_enabled = 10
sim_boolparam_mill_handling_enabled = 11
sim_boolparam_browser_visible = 12
sim_boolparam_scene_and_model_load_messages = 13
sim_boolparam_shape_textures_are_visible = 15
sim_boolparam_display_enabled = 16
sim_boolparam_infotext_visible = 17
sim_boolparam_statustext_open = 18
sim_boolparam_fog_enabled = 19
sim_boolparam_rml2_available = 20
sim_boolparam_rml4_available = 21
sim_boolparam_mirrors_enabled = 22
sim_boolparam_aux_clip_planes_enabled = 23
sim_boolparam_full_model_copy_from_api = 24
sim_boolparam_realtime_simulation = 25
sim_boolparam_force_show_wireless_emission = 27
sim_boolparam_force_show_wireless_reception = 28
sim_boolparam_video_recording_triggered = 29
sim_boolparam_threaded_rendering_enabled = 32
sim_boolparam_fullscreen = 33
sim_boolparam_headless = 34
sim_boolparam_force_calcstruct_all_visible = 39
sim_boolparam_force_calcstruct_all = 40
sim_boolparam_exit_request = 41
sim_boolparam_waiting_for_trigger = 45

sim_intparam_error_report_mode = 0
sim_intparam_program_version = 1
sim_intparam_instance_count = 2
sim_intparam_custom_cmd_start_id = 3
sim_intparam_compilation_version = 4
sim_intparam_current_page = 5
sim_intparam_flymode_camera_handle = 6
sim_intparam_dynamic_step_divider = 7
sim_intparam_dynamic_engine = 8
sim_intparam_server_port_start = 9
sim_intparam_server_port_range = 10
sim_intparam_visible_layers = 11
sim_intparam_infotext_style = 12
sim_intparam_settings = 13
sim_intparam_edit_mode_type = 14
sim_intparam_server_port_next = 15
sim_intparam_qt_version = 16
sim_intparam_event_flags_read = 17
sim_intparam_event_flags_read_clear = 18
sim_intparam_platform = 19
sim_intparam_scene_unique_id = 20
sim_intparam_work_thread_count = 21
sim_intparam_mouse_x = 22
sim_intparam_mouse_y = 23
sim_intparam_core_count = 24
sim_intparam_work_thread_calc_time_ms = 25
sim_intparam_idle_fps = 26
sim_intparam_prox_sensor_select_down = 27
sim_intparam_prox_sensor_select_up = 28
sim_intparam_stop_request_counter = 29
sim_intparam_program_revision = 30
sim_intparam_mouse_buttons = 31
sim_intparam_dynamic_warning_disabled_mask = 32
sim_intparam_simulation_warning_disabled_mask = 33
sim_intparam_scene_index = 34
sim_intparam_motionplanning_seed = 35
sim_intparam_speedmodifier = 36

sim_floatparam_rand = 0
sim_floatparam_simulation_time_step = 1
sim_floatparam_stereo_distance = 2

sim_stringparam_application_path = 0
sim_stringparam_video_filename = 1
sim_stringparam_app_arg1 = 2
sim_stringparam_app_arg2 = 3
sim_stringparam_app_arg3 = 4
sim_stringparam_app_arg4 = 5
sim_stringparam_app_arg5 = 6
sim_stringparam_app_arg6 = 7
sim_stringparam_app_arg7 = 8
sim_stringparam_app_arg8 = 9
sim_stringparam_app_arg9 = 10
sim_stringparam_scene_path_and_name = 13

sim_arrayparam_gravity = 0
sim_arrayparam_fog = 1
sim_arrayparam_fog_color = 2
sim_arrayparam_background_color1 = 3
sim_arrayparam_background_color2 = 4
sim_arrayparam_ambient_light = 5
sim_arrayparam_random_euler = 6
