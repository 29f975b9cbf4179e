"""Waveshare UGV boards with the firmware ugv_base_ros."""
