#pragma once

/// How often to try: sanitizers make each step six to ten times as slow, and what they look for shows in few.
#ifdef __SANITIZE_ADDRESS__
constexpr int tries(int, int with_sanitizers) { return with_sanitizers; }
#else
constexpr int tries(int without, int) { return without; }
#endif
