"""NXP's PCA9685, a chip with 16 PWM channels on an I2C bus: motors and servos on its channels."""
