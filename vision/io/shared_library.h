// A library that is loaded when it is first needed, not when the program starts.
#pragma once

#include <string>

namespace tribotrack::vision {

/// Most commands touch neither libav nor OpenCV's picture files, and loading these, with the hundred
/// libraries behind each, takes longer than such a command does. Stays loaded to the end of the program.
class SharedLibrary {
 public:
  /// `soname` as the linker would record it; `package` is Debian's; `purpose` begins the message: "video
  /// files". Throws InputError where it is not there.
  SharedLibrary(const std::string& soname, const std::string& package, const std::string& purpose);

  /// A function of it, or of the libraries it needs. Throws InputError where it has none of that name.
  template <class Function>
  void find(const char* name, Function*& function) const {
    function = reinterpret_cast<Function*>(address(name));
  }

 private:
  void* address(const char* name) const;
  [[noreturn]] void refuse() const;

  void* handle_ = nullptr;
  std::string soname_, package_, purpose_;
};

}  // namespace tribotrack::vision
