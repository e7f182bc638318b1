#include "core/io/common/parallel.h"

#include <atomic>
#include <exception>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace dynmesh::io {
namespace {

// Fewer blocks are no work for another thread.
constexpr std::size_t kFewBlocks = 4;

// Threads that run `work`, up to `most`; fewer if the system has no more. Joined at the end.
class Helpers {
 public:
  Helpers(int most, const std::function<void()>& work) {
    try {
      for (int i = 0; i < most; ++i) threads_.emplace_back(work);
    } catch (const std::system_error&) {
      // This thread does the work.
    } catch (const std::bad_alloc&) {
      // The same; those that have begun are joined.
    }
  }
  ~Helpers() {
    for (std::thread& thread : threads_) thread.join();
  }
  Helpers(const Helpers&) = delete;
  Helpers& operator=(const Helpers&) = delete;

 private:
  std::vector<std::thread> threads_;
};

// Blocks that several threads make and one writes. A block is made only shortly before it is to be
// written, so that few are in memory.
class Pipeline {
 public:
  Pipeline(std::size_t count, int threads, const std::function<void(std::size_t, TextBlock&)>& make)
      : count_(count), make_(make), slots_(2 * static_cast<std::size_t>(threads)) {}

  // On a thread that makes blocks, until there are none left.
  void Help() {
    MutexLock lock(mutex_);
    while (true) {
      changed_.Wait(
          mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return IsOver() || MayMake(); });
      if (IsOver()) return;
      MakeNext();
    }
  }

  // On the thread that writes. It makes blocks, too, while it has none to write.
  void Write(FileWriter& out) {
    MutexLock lock(mutex_);
    while (written_ < count_ && error_ == nullptr) {
      Slot& slot = slots_[written_ % slots_.size()];
      if (slot.is_made) {
        lock.Unlock();
        out << slot.text.text();
        lock.Lock();
        slot.is_made = false;
        ++written_;
        changed_.NotifyAll();
      } else if (MayMake()) {
        MakeNext();
      } else {
        changed_.Wait(mutex_, [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
          return slot.is_made || error_ != nullptr;
        });
      }
    }
  }

  // Lets the helpers end, also before all is written.
  class End {
   public:
    explicit End(Pipeline& pipeline) : pipeline_(pipeline) {}
    ~End() { pipeline_.Stop(); }
    End(const End&) = delete;
    End& operator=(const End&) = delete;

   private:
    Pipeline& pipeline_;
  };

  std::exception_ptr error() {
    const MutexLock lock(mutex_);
    return error_;
  }

 private:
  struct Slot {
    TextBlock text;
    bool is_made = false;
  };

  void Stop() {
    const MutexLock lock(mutex_);
    is_stopped_ = true;
    changed_.NotifyAll();
  }
  bool IsOver() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return next_ == count_ || is_stopped_ || error_ != nullptr;
  }
  bool MayMake() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return next_ < count_ && next_ < written_ + slots_.size();
  }
  void MakeNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const std::size_t block = next_++;
    Slot& slot = slots_[block % slots_.size()];
    mutex_.Unlock();
    std::exception_ptr error;
    try {
      slot.text.Clear();
      make_(block, slot.text);
    } catch (...) {
      error = std::current_exception();
    }
    mutex_.Lock();
    slot.is_made = error == nullptr;
    if (error != nullptr) error_ = error;
    changed_.NotifyAll();
  }

  const std::size_t count_;
  const std::function<void(std::size_t, TextBlock&)>& make_;
  Mutex mutex_;
  CondVar changed_;
  // The text of a slot is of the thread that makes or writes its block.
  std::vector<Slot> slots_;
  std::size_t next_ ABSL_GUARDED_BY(mutex_) = 0;     // block to make
  std::size_t written_ ABSL_GUARDED_BY(mutex_) = 0;  // blocks
  bool is_stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::exception_ptr error_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

void ForEachBlock(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  Mutex mutex;
  std::exception_ptr error;
  const std::function<void()> run = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) work(i);
    } catch (...) {
      next = count;
      const MutexLock lock(mutex);
      error = std::current_exception();
    }
  };
  {
    const Helpers helpers(std::min(threads, static_cast<int>(std::min<std::size_t>(count, 64))) - 1,
                          run);
    run();
  }
  if (error != nullptr) std::rethrow_exception(error);
}

void WriteBlocks(std::size_t count, int threads, FileWriter& out,
                 const std::function<void(std::size_t, TextBlock&)>& make) {
  if (threads < 2 || count < kFewBlocks) {
    TextBlock text;
    for (std::size_t i = 0; i < count; ++i) {
      text.Clear();
      make(i, text);
      out << text.text();
    }
    return;
  }
  Pipeline pipeline(count, threads, make);
  {
    const Helpers helpers(threads - 1, [&] { pipeline.Help(); });
    const Pipeline::End end(pipeline);
    pipeline.Write(out);
  }
  if (const std::exception_ptr error = pipeline.error()) std::rethrow_exception(error);
}

}  // namespace dynmesh::io
