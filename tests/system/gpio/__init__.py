"""A real GPIO chip and a real camera, as the kernel of a virtual machine simulates them."""
