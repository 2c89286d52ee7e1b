// Output files that appear whole or not at all, and never in place of something else.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/program/errors.h"

namespace tribotrack::apps {

/// An output that cannot be written: what comes after it would fare no better. Exit 3.
class OutputError : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// What a file is to hold. A name that ends like a recording's or a picture's is refused for a result: it is
/// a slip, and may be somebody's only copy.
enum class Content { result, pictures };

/// One output of a command.
struct Output {
  std::filesystem::path path;
  Content content = Content::result;
};

/// Checks before any work what a command is about to write. Throws InvalidInput where an output
/// - is the same file (links included) as an input or another output, or its X.meta.json is,
/// - exists and is not a regular file, or is write-protected,
/// - is a result with the name of a recording,
/// - lies in a folder that does not exist or cannot be written to.
/// `inputs` are single files: a recording of many files is listed file by file.
void require_writable(const std::vector<Output>& outputs,
                      const std::vector<std::filesystem::path>& inputs = {});
inline void require_writable(const std::filesystem::path& path, Content content = Content::result) {
  require_writable(std::vector<Output>{{path, content}});
}

/// "-", or a name of this process's standard output: results that can be streamed go to print_text().
bool is_standard_output(const std::filesystem::path& path);

/// By vision/temporary_file.h. Throws InvalidInput naming the path where it must not be written (see
/// require_writable), OutputError where it cannot be.
void write_file(const std::filesystem::path& path, std::string_view text, Content content = Content::result);

/// Creates a folder and its parents. Throws InvalidInput.
void create_folder(const std::filesystem::path& path);

/// Removes temporary files that were left behind in `folder` (killed, or the machine went down). Only where
/// no other process of this program can be writing there.
void remove_leftovers(const std::filesystem::path& folder);

/// From here on SIGINT, SIGTERM and SIGHUP remove the temporary files of this process before it ends, which
/// is said on stderr, and a file beyond the limit on its size (SIGXFSZ) is an error of writing like any
/// other.
void clean_up_on_signals();

}  // namespace tribotrack::apps
