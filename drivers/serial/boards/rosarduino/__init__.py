"""ROSArduinoBridge, and our firmware that speaks it: ASCII lines."""
