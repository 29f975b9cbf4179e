"""Motor boards, a folder each: the frames and the protocol of a board, and its device drivers."""
