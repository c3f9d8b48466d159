"""What everything else builds on: LLVM, arrays on the device, directions, hashes, the wording of messages."""
