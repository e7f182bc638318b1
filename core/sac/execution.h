// What an operation makes and reads while it runs, until the engine commits it.
#ifndef DYNMESH_CORE_SAC_EXECUTION_H_
#define DYNMESH_CORE_SAC_EXECUTION_H_

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/sac/program.h"
#include "core/sac/subscriptions.h"
#include "core/sac/work_queue.h"

namespace dynmesh::sac {

struct Execution {
  struct Requested {
    Item item;
    Epoch epoch;
    Kind kind;
  };
  std::vector<Output> outputs;
  std::vector<Requested> requests;
  std::vector<std::pair<Place, Parts>> subscriptions;
  std::vector<Place> places;  // those of `subscriptions`, after JoinSubscriptions
  std::vector<std::uint32_t> reads;

  void Clear() {
    outputs.clear();
    requests.clear();
    subscriptions.clear();
    reads.clear();
  }
  // Sorts the subscriptions and merges those of one place: their parts are united.
  void JoinSubscriptions();
  bool Exceeds(const EngineLimits& limits) const {
    const auto over = [](std::size_t size, std::uint32_t most) { return size > most ? 1 : 0; };
    return (over(outputs.size(), limits.outputs) | over(places.size(), limits.places) |
            over(requests.size(), limits.requests) | over(reads.size(), limits.reads)) != 0;
  }
};

inline void Execution::JoinSubscriptions() {
  std::sort(subscriptions.begin(), subscriptions.end());
  places.clear();
  std::size_t count = 0;
  for (const auto& subscription : subscriptions) {
    if (count > 0 && subscriptions[count - 1].first == subscription.first) {
      subscriptions[count - 1].second |= subscription.second;
    } else {
      subscriptions[count++] = subscription;
      places.push_back(subscription.first);
    }
  }
  subscriptions.resize(count);
}

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_EXECUTION_H_
