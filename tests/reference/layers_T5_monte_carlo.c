/* Layers of hard spheres at the base of a column, T = 5 m g d, 40 spheres per area: n(x) by plain Metropolis Monte Carlo.

   Independent of the library: own start (a simple cubic lattice, which melts), overlap test, cells and random numbers.

   Displacements of single spheres renew the layers soon, but the column as a whole breathes so slowly that n at the base, which
   follows its height, is known from a run no better than from a few configurations. So the error bars are those of the mean of
   independent runs. For each bin: low edge, high edge, n and its standard error.

       cc -O2 -o layers layers_T5_monte_carlo.c -lm && ./layers RUNS DISCARDED_SWEEPS MEASURED_SWEEPS */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SPHERES = 2560, ACROSS = 8, UP = 150, MOST_IN_CELL = 8, ROW = 7, BINS = 36, MOST_RUNS = 100, INTERVAL = 5 };
static const double WIDTH = ACROSS, HEIGHT = UP, TEMPERATURE = 5.0, BIN = 0.1;

static double position[SPHERES][3]; /* x is the height of a centre, y and z are periodic */
static int cell[UP][ACROSS][ACROSS][MOST_IN_CELL], count[UP][ACROSS][ACROSS];

static uint64_t state[2]; /* xorshift128+ */
static double uniform(void) {
    uint64_t a = state[0], b = state[1];
    state[0] = b;
    a ^= a << 23;
    state[1] = a ^ b ^ (a >> 17) ^ (b >> 26);
    return (double)((state[1] + b) >> 11) * 0x1p-53;
}

static void fail(const char *message) {
    fprintf(stderr, "%s\n", message);
    exit(1);
}

static void put(int sphere) {
    const double *p = position[sphere];
    int *here = &count[(int)p[0]][(int)p[1]][(int)p[2]];
    if (*here == MOST_IN_CELL) fail("a cell is full");
    cell[(int)p[0]][(int)p[1]][(int)p[2]][(*here)++] = sphere;
}

static void take(int sphere) {
    const double *p = position[sphere];
    int *list = cell[(int)p[0]][(int)p[1]][(int)p[2]], *here = &count[(int)p[0]][(int)p[1]][(int)p[2]];
    for (int i = 0; i < *here; i++) {
        if (list[i] == sphere) {
            list[i] = list[--*here];
            return;
        }
    }
    fail("a sphere is not in its cell");
}

static int overlaps(const double *p, int self) {
    for (int i = (int)p[0] - 1; i <= (int)p[0] + 1; i++) {
        if (i < 0 || i >= UP) continue;
        for (int j = (int)p[1] + ACROSS - 1; j <= (int)p[1] + ACROSS + 1; j++) {
            for (int k = (int)p[2] + ACROSS - 1; k <= (int)p[2] + ACROSS + 1; k++) {
                const int *list = cell[i][j % ACROSS][k % ACROSS];
                for (int m = 0; m < count[i][j % ACROSS][k % ACROSS]; m++) {
                    const double *q = position[list[m]];
                    double dx = p[0] - q[0], dy = p[1] - q[1], dz = p[2] - q[2];
                    dy -= WIDTH * rint(dy / WIDTH);
                    dz -= WIDTH * rint(dz / WIDTH);
                    if (list[m] != self && dx * dx + dy * dy + dz * dz < 1.0) return 1;
                }
            }
        }
    }
    return 0;
}

static void trial(void) {
    int sphere = (int)(uniform() * SPHERES);
    /* Small ones for the structure, some that pass a neighbour, and some between layers, for the column as a whole. */
    double choice = uniform(), largest = choice < 0.5 ? 0.15 : choice < 0.8 ? 0.4 : 10.0, q[3];
    for (int axis = 0; axis < 3; axis++) q[axis] = position[sphere][axis] + largest * (2.0 * uniform() - 1.0);
    if (q[0] < 0.5 || q[0] > HEIGHT - 0.5) return;
    for (int axis = 1; axis < 3; axis++) {
        q[axis] -= WIDTH * floor(q[axis] / WIDTH);
        if (q[axis] >= WIDTH) q[axis] = 0.0;
    }
    double rise = (q[0] - position[sphere][0]) / TEMPERATURE;
    if (rise > 0.0 && uniform() >= exp(-rise)) return;
    if (overlaps(q, sphere)) return;
    take(sphere);
    memcpy(position[sphere], q, sizeof q);
    put(sphere);
}

static void lattice(void) {
    double gap = WIDTH / ROW;
    memset(count, 0, sizeof count);
    for (int sphere = 0; sphere < SPHERES; sphere++) {
        position[sphere][0] = 0.51 + gap * (sphere / (ROW * ROW));
        position[sphere][1] = gap * (sphere % ROW);
        position[sphere][2] = gap * (sphere / ROW % ROW);
        put(sphere);
    }
}

/* Writes the densities of one run and returns its mean height. */
static double run(long discarded, long measured, double *density) {
    double height = 0.0, frames = 0.0;
    lattice();
    for (int bin = 0; bin < BINS; bin++) density[bin] = 0.0;
    for (long sweep = 0; sweep < discarded + measured; sweep++) {
        for (int i = 0; i < SPHERES; i++) trial();
        if (sweep < discarded || sweep % INTERVAL != 0) continue;
        frames += 1.0;
        for (int sphere = 0; sphere < SPHERES; sphere++) {
            height += position[sphere][0] / SPHERES;
            int bin = (int)((position[sphere][0] - 0.5) / BIN);
            if (bin < BINS) density[bin] += 1.0;
        }
    }
    for (int bin = 0; bin < BINS; bin++) density[bin] /= frames * WIDTH * WIDTH * BIN;
    return height / frames;
}

int main(int arguments, char **argument) {
    if (arguments != 4) fail("usage: layers RUNS DISCARDED_SWEEPS MEASURED_SWEEPS");
    int runs = atoi(argument[1]);
    if (runs < 2 || runs > MOST_RUNS) fail("take 2 to 100 runs");
    static double density[MOST_RUNS][BINS];
    for (int i = 0; i < runs; i++) {
        state[0] = 88172645463325252ULL + 77777ULL * (uint64_t)i;
        state[1] = 1234567ULL;
        for (int j = 0; j < 100; j++) uniform();
        fprintf(stderr, "run %d: h_c %.3f\n", i, run(atol(argument[2]), atol(argument[3]), density[i]));
    }
    printf("x_lo,x_hi,n,standard_error\n");
    for (int bin = 0; bin < BINS; bin++) {
        double mean = 0.0, squares = 0.0;
        for (int i = 0; i < runs; i++) mean += density[i][bin] / runs;
        for (int i = 0; i < runs; i++) squares += pow(density[i][bin] - mean, 2.0);
        printf("%.1f,%.1f,%.4f,%.4f\n", 0.5 + BIN * bin, 0.6 + BIN * bin, mean,
               sqrt(squares / runs / (runs - 1)));
    }
    return 0;
}
