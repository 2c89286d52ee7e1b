// Threads of the picture library.
#pragma once

namespace tribotrack::vision {

/// Keeps OpenCV's own functions on the calling thread, for the whole process: recordings are worked on side
/// by side, one a thread, and a thread count the user gives then means what it says.
void keep_to_calling_thread();

}  // namespace tribotrack::vision
