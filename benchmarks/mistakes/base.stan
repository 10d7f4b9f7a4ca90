data {
  int<lower=0> n;
  array[n] real y;
  array[n] int g;
}
parameters {
  real mu;
  real<lower=0> sigma;
  vector[3] b;
}
model {
  mu ~ normal(0, 1);
  sigma ~ exponential(1);
  b ~ normal(0, 1);
  for (i in 1:n) {
    if (g[i] == 1) {
      y[i] ~ normal(mu, sigma);
    } else {
      y[i] ~ normal(b[g[i]], sigma);
    }
  }
}
