"""What is said on Zenoh: messages, their bytes and their keys; public."""
