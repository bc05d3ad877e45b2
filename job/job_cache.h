// Keeps what several jobs of a process have in common, within a limit of memory.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace skywave {

// A cache of values that are expensive to make, by text keys. What has not been asked for for the
// longest time is dropped first; whoever holds a value keeps it alive, and it is found as long as
// somebody does. What nobody has asked for again may have less room, so that a thousand values that
// are needed once each do not fill the memory (segmented LRU: Karedla et al. 1994). Threads may
// share a cache.
class JobCache {
 public:
  // What is kept takes at most about this memory [bytes], besides what is in use; 0: what has been
  // asked for once has all of it.
  explicit JobCache(std::uint64_t most_bytes, std::uint64_t most_bytes_of_once = 0)
      : most_bytes_(most_bytes),
        most_bytes_of_once_(most_bytes_of_once > 0 ? most_bytes_of_once : most_bytes) {}

  // Returns the value of `key`, a `T` of so many `bytes()`. `make` makes it if it is not there;
  // other threads that ask for it meanwhile wait. If `make` throws, they get its exception too, and
  // nothing is kept. Keys of values of different types differ.
  template <class T>
  std::shared_ptr<const T> Get(const std::string& key,
                               const std::function<std::shared_ptr<const T>()>& make) {
    std::promise<Value> promise;
    const auto [value, is_new] = Find(key, promise);
    if (is_new)
      Fill(key, promise, [&] {
        std::shared_ptr<const T> made = make();
        const std::uint64_t bytes = made->bytes();
        return std::pair<Value, std::uint64_t>(std::move(made), bytes);
      });
    return std::static_pointer_cast<const T>(value.get());
  }

  // Drops everything whose key begins with `prefix`.
  void Forget(const std::string& prefix);

  std::uint64_t bytes() const;  // of what is kept

 private:
  using Value = std::shared_ptr<const void>;
  struct Entry {
    std::shared_future<Value> value;  // invalid: it was dropped
    std::weak_ptr<const void> held;   // the value, once it is made
    std::uint64_t bytes = 0, last_use = 0;
    bool made = false, asked_again = false;
  };

  // Returns the value of an entry, and whether the caller has to make it: then `promise` is its.
  std::pair<std::shared_future<Value>, bool> Find(const std::string& key,
                                                  std::promise<Value>& promise);
  void Fill(const std::string& key, std::promise<Value>& promise,
            const std::function<std::pair<Value, std::uint64_t>()>& make);
  // Drops the oldest values for which is(entry) is true until they have at most so many bytes.
  template <class Is>
  void DropOldest(std::uint64_t most_bytes, const Is& is);
  void DropOldest();

  const std::uint64_t most_bytes_, most_bytes_of_once_;
  mutable std::mutex mutex_;  // of what follows
  std::map<std::string, Entry> entries_;
  std::uint64_t bytes_ = 0, uses_ = 0;
};

}  // namespace skywave
