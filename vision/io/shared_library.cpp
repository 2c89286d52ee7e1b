#include "vision/io/shared_library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "vision/picture.h"

namespace tribotrack::vision {

SharedLibrary::SharedLibrary(const std::string& soname, const std::string& package,
                             const std::string& purpose)
    : soname_(soname), package_(package), purpose_(purpose) {
  handle_ = dlopen(soname.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!handle_) refuse();
}

void* SharedLibrary::address(const char* name) const {
  void* found = dlsym(handle_, name);
  if (!found) refuse();
  return found;
}

void SharedLibrary::refuse() const {
  const char* reason = dlerror();
  throw InputError(
      fmt::format("{} need the library {}, which cannot be used here ({}); install Debian's package {}",
                  purpose_, soname_, reason ? reason : "no reason given", package_));
}

}  // namespace tribotrack::vision
