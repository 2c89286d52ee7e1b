// Integration takes its memory once, not step by step.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "model/laws.h"
#include "model/trajectory.h"

namespace {

thread_local long allocations = 0;

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  size = (size + alignment - 1) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace tribotrack::model {
namespace {

using laws::kPi;

long allocations_of(const Scenario& s, const IntegrationOptions& options) {
  integrate(s, options);  // tables are made once
  const long before = allocations;
  integrate(s, options);
  return allocations - before;
}

/// Ten times the cycles, sliding or sticking, with derivatives or none, take no more allocations.
TEST(Allocation, NoneInTheLoop) {
  for (const double mu1 : {0.05, 0.1, 0.122, 0.3})
    for (const int derivatives : {0, 3, 8})
      for (const bool reuse : {true, false}) {
        IntegrationOptions options;
        options.dense = false;
        options.reuse_repeating_cycles = reuse;
        for (int i = 0; i < derivatives; ++i) options.derivatives.push_back(static_cast<Parameter>(i));
        Scenario s;
        s.friction = {mu1, mu1 / 8, 0.5, kPi / 6, 0};
        s.cycles = 5.5;
        const long few = allocations_of(s, options);
        s.cycles = 55.5;
        EXPECT_EQ(allocations_of(s, options), few)
            << "mu1 " << mu1 << " derivatives " << derivatives << " reuse " << reuse;
        EXPECT_LE(few, 8);
      }
}

}  // namespace
}  // namespace tribotrack::model
