// What integrators and policies keep in the options, the workers and the frame of a picture, none
// of which knows them: one value of a type, found by its type.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace skywave {

// Each type has an address of its own.
using SlotKey = const void*;
template <class T>
inline char slot_tag = 0;
template <class T>
SlotKey KeyOf() {
  return &slot_tag<T>;
}

// Values that are copied with their holder. Copies share what none of them changes, so that a copy
// allocates nothing.
class ValueSlots {
 public:
  // The value of a type; that of its default constructor if nobody has set one.
  template <class T>
  const T& of() const {
    if (slots_ != nullptr) {
      for (const Slot& slot : *slots_) {
        if (slot.key == KeyOf<T>()) return *static_cast<const T*>(slot.value.get());
      }
    }
    static constexpr T kUnset = {};
    return kUnset;
  }
  // The same to be changed; allocates.
  template <class T>
  T& of() {
    auto value = std::make_shared<T>(std::as_const(*this).template of<T>());
    T& changed = *value;
    std::vector<Slot> slots;
    if (slots_ != nullptr) {
      for (const Slot& slot : *slots_) {
        if (slot.key != KeyOf<T>()) slots.push_back(slot);
      }
    }
    slots.push_back({KeyOf<T>(), std::move(value)});
    slots_ = std::make_shared<const std::vector<Slot>>(std::move(slots));
    return changed;
  }

 private:
  struct Slot {
    SlotKey key;
    std::shared_ptr<const void> value;
  };
  std::shared_ptr<const std::vector<Slot>> slots_;
};

// Tables that their holder owns.
class TableSlots {
 public:
  // Makes the table of a type, of which there was none.
  template <class T, class... Arguments>
  T& Add(Arguments&&... arguments) {
    assert(find<T>() == nullptr);
    auto table = std::make_shared<T>(std::forward<Arguments>(arguments)...);
    T& added = *table;
    slots_.push_back({KeyOf<T>(), std::move(table)});
    return added;
  }
  // Null if there is none.
  template <class T>
  T* find() const {
    for (const Slot& slot : slots_) {
      if (slot.key == KeyOf<T>()) return static_cast<T*>(slot.table.get());
    }
    return nullptr;
  }

 private:
  struct Slot {
    SlotKey key;
    std::shared_ptr<void> table;  // shared for its deleter alone
  };
  std::vector<Slot> slots_;
};

// Pointers to what others own and a frame shows its stages.
class ViewSlots {
 public:
  // Null takes away what there was.
  template <class T>
  void Set(const T* value) {
    for (Slot& slot : slots_) {
      if (slot.key != KeyOf<T>() && slot.key != nullptr) continue;
      slot = {KeyOf<T>(), value};
      return;
    }
    assert(!"more kinds of data than a frame has room for");
  }
  template <class T>
  const T* find() const {
    for (const Slot& slot : slots_) {
      if (slot.key == KeyOf<T>()) return static_cast<const T*>(slot.value);
      if (slot.key == nullptr) break;  // so are those after it
    }
    return nullptr;
  }

 private:
  struct Slot {
    SlotKey key = nullptr;
    const void* value = nullptr;
  };
  std::array<Slot, 7> slots_;
};

}  // namespace skywave
