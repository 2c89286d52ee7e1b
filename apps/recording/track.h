// Then: the part is followed through the recording, and its table made.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/program/errors.h"
#include "apps/recording/recording.h"

namespace tribotrack::apps {

/// Several discs may be the part. what() lists them, each with the --disc that chooses it.
class AmbiguousPart : public InvalidInput {
 public:
  AmbiguousPart(const std::string& what, const vision::AmbiguousTarget& question)
      : InvalidInput(what), frame(question.frame), discs(question.discs) {}
  std::int64_t frame;                 ///< the recording's own number: where all of them are seen
  std::vector<vision::Circle> discs;  ///< px
};

/// A checked recording with its track. Throws vision::InputError where it cannot be tracked; what
/// require_trackable() throws; InvalidInput where it has changed since it was checked; AmbiguousPart, before
/// which a picture that numbers the discs is written beside the result `beside` (question_picture()), or
/// none.
Recording tracked(Recording recording, const std::optional<std::filesystem::path>& beside);
/// The same for frames in memory.
Recording tracked(Recording recording, std::shared_ptr<vision::FrameSource> source);

/// OUT/x.csv -> OUT/x.discs.png; of standard output, x.discs.png for a recording x.mp4.
std::filesystem::path question_picture(const std::filesystem::path& beside,
                                       const std::filesystem::path& recording);

}  // namespace tribotrack::apps
