#include "job/job_cache.h"

#include <algorithm>
#include <exception>

namespace skywave {

std::uint64_t JobCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::pair<std::shared_future<JobCache::Value>, bool> JobCache::Find(const std::string& key,
                                                                    std::promise<Value>& promise) {
  const std::lock_guard lock(mutex_);
  const auto [entry, is_new] = entries_.try_emplace(key);
  if (is_new) entry->second.value = promise.get_future().share();
  entry->second.last_use = ++uses_;
  return {entry->second.value, is_new};
}

void JobCache::Fill(const std::string& key, std::promise<Value>& promise,
                    const std::function<std::pair<Value, std::uint64_t>()>& make) {
  try {
    auto [value, bytes] = make();
    promise.set_value(std::move(value));
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_.at(key);
    entry.bytes = bytes, entry.made = true;
    bytes_ += bytes;
    DropOldest();
  } catch (...) {
    promise.set_exception(std::current_exception());
    const std::lock_guard lock(mutex_);
    entries_.erase(key);
  }
}

void JobCache::DropOldest() {
  while (bytes_ > most_bytes_) {
    auto oldest = entries_.end();
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      if (!entry->second.made) continue;
      if (oldest == entries_.end() || entry->second.last_use < oldest->second.last_use) {
        oldest = entry;
      }
    }
    if (oldest == entries_.end()) return;
    bytes_ -= oldest->second.bytes;
    entries_.erase(oldest);
  }
}

}  // namespace skywave
