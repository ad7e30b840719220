#include "tools/accuracy/rendered_sets.hpp"

#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "tools/io/input_error.hpp"
#include "tools/render/dataset_writer.hpp"
#include "tools/render/random.hpp"

namespace vergence::accuracy {
namespace {

constexpr const char* kStamp = "rendered.txt";
// To be raised when the renderer draws anything otherwise than before.
constexpr int kRendererEdition = 1;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw tools::InputError(file, "", "no such scene", "--scenes says where tools/render/scenes is");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::uint64_t hash_of(const std::string& text) {
  std::uint64_t h = kRendererEdition;
  for (const char c : text) h = render::hash(h, static_cast<unsigned char>(c));
  return h;
}

bool is_there(const std::filesystem::path& directory, std::uint64_t wanted, int frames) {
  std::ifstream in(directory / kStamp);
  std::uint64_t hash = 0;
  int rendered = 0;
  return in >> hash >> rendered && hash == wanted && rendered >= frames;
}

void render(const std::filesystem::path& scene_file, const RenderedSet& set,
            const std::filesystem::path& directory, std::uint64_t hash) {
  std::filesystem::remove_all(directory);
  render::SceneOverrides overrides;
  overrides.patch = set.patch;
  const render::Scene scene = render::load_scene(scene_file, overrides);
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  render::write_dataset(scene, directory, set.frames, cores, [] {});
  std::ofstream stamp(directory / kStamp);
  stamp << hash << ' ' << set.frames << '\n';
}

}  // namespace

std::filesystem::path directory_of(const Places& places, const RenderedSet& set) {
  return places.work / set.name;
}

void render_missing(const Places& places, const std::vector<RenderedSet>& sets,
                    const std::function<void()>& rendered) {
  std::map<std::string, std::uint64_t> done;
  for (const RenderedSet& set : sets) {
    const std::filesystem::path scene_file = places.scenes / (set.scene + ".toml");
    const std::uint64_t hash = hash_of(text_of(scene_file) + '\0' + set.patch);
    if (const auto [entry, is_new] = done.emplace(set.name, hash); !is_new && entry->second != hash) {
      throw std::logic_error("two data sets of the suite are called " + set.name);
    }
    const std::filesystem::path directory = directory_of(places, set);
    if (!is_there(directory, hash, set.frames)) render(scene_file, set, directory, hash);
    rendered();
  }
}

}  // namespace vergence::accuracy
