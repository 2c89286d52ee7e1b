#include "vision/io/shared_library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/picture.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string complaint(const std::string& soname, const char* name) {
  try {
    double (*function)(double) = nullptr;
    SharedLibrary(soname, "libexample6", "example files").find(name, function);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SharedLibraryTest, FindsFunctions) {
  double (*cosine)(double) = nullptr;
  SharedLibrary("libm.so.6", "libc6", "tests").find("cos", cosine);
  EXPECT_EQ(cosine(0), 1);
}

TEST(SharedLibraryTest, SaysWhatIsMissingAndWhatToInstall) {
  EXPECT_THAT(complaint("libexample.so.6", "cos"),
              AllOf(HasSubstr("example files need the library libexample.so.6"), HasSubstr("No such file"),
                    HasSubstr("install Debian's package libexample6")));
  EXPECT_THAT(complaint("libm.so.6", "no_such_function"),
              AllOf(HasSubstr("libm.so.6"), HasSubstr("no_such_function")));
}

}  // namespace
}  // namespace tribotrack::vision
