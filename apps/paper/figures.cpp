#include "apps/paper/figures.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace tribotrack::apps {

std::vector<Figure> paper_figures(int threads) {
  std::vector<Figure> figures = paper_trajectories();
  std::ranges::move(paper_dependences(threads), std::back_inserter(figures));
  std::ranges::sort(figures, {}, number_of);
  return figures;
}

int number_of(const Figure& figure) {
  return std::atoi(figure.id.c_str() + figure.id.find_first_of("0123456789"));
}

}  // namespace tribotrack::apps
