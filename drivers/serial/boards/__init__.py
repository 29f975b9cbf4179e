"""Motor boards, a folder each: its frames (protocol), the conversation with it (board), and its device drivers."""
