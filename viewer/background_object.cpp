#include "viewer/background_object.h"

#include "viewer/transfer.h"

#include <utility>

namespace lightgrid {

BackgroundObject::BackgroundObject()
    : answer_([](const Load& load, const auto& turn) {
          const ObjectMesh mesh = load();
          ObjectMesh shown = mesh;
          turn.tell([&](std::optional<ObjectNews>& news) { news = ObjectNews{std::move(shown), {}}; });
          TransferOptions options = shown_transfer(mesh);
          options.step = [&] { turn.check(); };
          std::vector<float> transfer = self_shadowed_transfer(mesh, options);
          turn.tell([&](std::optional<ObjectNews>& news) {
              if (!news) news.emplace();
              news->transfer = std::move(transfer);
          });
      }) {}

}  // namespace lightgrid
