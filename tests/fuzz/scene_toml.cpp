// A scene, for `synth`.
#include "apps/files/scene_file.h"
#include "fuzz/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tribotrack;
  static const fuzz::Folder folder;
  const auto file = folder.write("scene.toml", data, size);
  fuzz::read_or_refuse(data, size, [&] {
    try {
      for (const apps::SceneShot& shot : apps::read_scene_file(file)) apps::text_of(apps::json_of(shot));
    } catch (const std::invalid_argument& refusal) {  // of Scene::validate
      throw apps::InvalidInput(refusal.what());
    }
  });
  return 0;
}
