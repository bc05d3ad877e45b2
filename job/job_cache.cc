#include "job/job_cache.h"

#include <algorithm>
#include <exception>
#include <vector>

namespace skywave {

std::uint64_t JobCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::pair<std::shared_future<JobCache::Value>, bool> JobCache::Find(const std::string& key,
                                                                    std::promise<Value>& promise) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[key];
  entry.last_use = ++uses_;
  if (entry.value.valid()) {
    entry.asked_again = true;
    return {entry.value, false};
  }
  if (Value held = entry.held.lock()) {
    promise.set_value(std::move(held));
    entry.value = promise.get_future().share();
    entry.asked_again = true;
    bytes_ += entry.bytes;
    std::shared_future<Value> value = entry.value;
    DropOldest();
    return {std::move(value), false};
  }
  entry.value = promise.get_future().share();
  entry.made = false;
  return {entry.value, true};
}

void JobCache::Fill(const std::string& key, std::promise<Value>& promise,
                    const std::function<std::pair<Value, std::uint64_t>()>& make) {
  try {
    auto [value, bytes] = make();
    promise.set_value(value);
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end()) return;  // it was forgotten meanwhile
    Entry& entry = found->second;
    entry.held = value, entry.bytes = bytes, entry.made = true;
    bytes_ += bytes;
    value.reset();  // nobody holds it on account of this call
    DropOldest();
  } catch (...) {
    promise.set_exception(std::current_exception());
    const std::lock_guard lock(mutex_);
    entries_.erase(key);
  }
}

template <class Is>
void JobCache::DropOldest(std::uint64_t most_bytes, const Is& is) {
  std::vector<Entry*> kept;
  std::uint64_t bytes = 0;
  for (auto& [key, entry] : entries_) {
    if (!entry.made || !entry.value.valid() || !is(entry)) continue;
    kept.push_back(&entry);
    bytes += entry.bytes;
  }
  if (bytes <= most_bytes) return;
  std::sort(kept.begin(), kept.end(),
            [](const Entry* a, const Entry* b) { return a->last_use < b->last_use; });
  for (Entry* entry : kept) {
    if (bytes <= most_bytes) return;
    bytes -= entry->bytes, bytes_ -= entry->bytes;
    entry->value = {};
  }
}

void JobCache::DropOldest() {
  std::erase_if(entries_, [](const auto& entry) {
    return !entry.second.value.valid() && entry.second.held.expired();
  });
  DropOldest(most_bytes_of_once_, [](const Entry& entry) { return !entry.asked_again; });
  DropOldest(most_bytes_, [](const Entry&) { return true; });
}

void JobCache::Forget(const std::string& prefix) {
  const std::lock_guard lock(mutex_);
  auto entry = entries_.lower_bound(prefix);
  while (entry != entries_.end() && entry->first.starts_with(prefix)) {
    if (entry->second.made && entry->second.value.valid()) bytes_ -= entry->second.bytes;
    entry = entries_.erase(entry);
  }
}

}  // namespace skywave
