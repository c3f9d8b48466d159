"""What everything else stands on: LLVM, arrays on the device, directions, hashes, words of messages."""
