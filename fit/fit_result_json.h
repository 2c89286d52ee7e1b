// A FitResult as the object of fit.json, and back: one list of keys for both ways, in fit_result_json.cpp.
//
//   const Json fit = in_key_units(estimate(problem), mm_per_px);  // to_json
//   const FitResult shown = fit.get<FitResult>();                 // from_json; throws WrongContent
#pragma once

#include "fit/fit_result.h"
#include "fit/json.h"

namespace tribotrack::fit {

/// From SI to the unit that a parameter's key carries (amplitude_mm: 1e3). `mm_per_px`: what a scale of 1 is.
double key_unit_per_si(FitParameter parameter, double mm_per_px);

/// The same result with all that is a value, an sd or an end of a parameter's interval in the unit of its
/// key, and the sources of the budget in that of their quantity: as fit.json holds them and people read them.
/// Everything else stays SI.
FitResult in_key_units(FitResult result, double mm_per_px);

/// `shown`: in the units of the keys. An end that is open and what is no number become null.
void to_json(Json& json, const FitResult& shown);
/// Of `runs` those that took part. What an older file does not hold is NaN or empty; throws WrongContent
/// naming the key where one that every file holds is missing, or one is of the wrong kind. What fit.json does
/// not hold (covariance, counts of the search) stays as it was.
void from_json(const Json& json, FitResult& shown);

/// An entry of `slides`.
void to_json(Json& json, const SlideResult& slide);

}  // namespace tribotrack::fit
