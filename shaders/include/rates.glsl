// rates: what a pass does to the trail on an object. Twin: RatesOfTexels of src/sim/spread.rs.
// The includer declares the constant OWN_RATES, `params` with the rates that all objects share and the first of the pass in the table, and
// that table, `rates`.

#ifndef MYXO_RATES
#define MYXO_RATES

// Texels without an owner have object 0, and stay empty.
TrailRates rates_on(uint object) {
    if (OWN_RATES) return rates[params.first_rates + object];
    return TrailRates(params.diffusion, params.deposit, params.decay, 0.0);
}

#endif
