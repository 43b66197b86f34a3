/* Layers of hard spheres at the base of a column, T = 5 m g d, 40 spheres per area: n(x) by plain Metropolis Monte Carlo.

   Independent of the library: own start (a simple cubic lattice, which melts), overlap test, cells and random numbers.

   Displacements of single spheres renew the layers soon, but the column as a whole breathes so slowly that its centre of mass has
   few independent heights, and n at the base follows it. So the means over blocks are fitted by n = a + b (h_c - HEIGHT): a is n
   in a column whose centre of mass is where theory has it. For each bin: low edge, high edge, a and its standard error.

       cc -O2 -o layers layers_T5_monte_carlo.c -lm && ./layers SEED DISCARDED_SWEEPS MEASURED_SWEEPS HEIGHT */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SPHERES = 2560, ACROSS = 8, UP = 150, MOST_IN_CELL = 8, ROW = 7, BINS = 36, BLOCKS = 32, INTERVAL = 5 };
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

int main(int arguments, char **argument) {
    if (arguments != 5) fail("usage: layers SEED DISCARDED_SWEEPS MEASURED_SWEEPS HEIGHT");
    long discarded = atol(argument[2]), measured = atol(argument[3]);
    state[0] = 88172645463325252ULL + 77777ULL * strtoull(argument[1], NULL, 10);
    state[1] = 1234567ULL;
    for (int i = 0; i < 100; i++) uniform();
    for (int sphere = 0; sphere < SPHERES; sphere++) {
        double gap = WIDTH / ROW;
        position[sphere][0] = 0.51 + gap * (sphere / (ROW * ROW));
        position[sphere][1] = gap * (sphere % ROW);
        position[sphere][2] = gap * (sphere / ROW % ROW);
        put(sphere);
    }
    static double inside[BLOCKS][BINS], height[BLOCKS];
    long frames = 0;
    for (long sweep = 0; sweep < discarded + measured; sweep++) {
        for (int i = 0; i < SPHERES; i++) trial();
        if (sweep < discarded || sweep % INTERVAL != 0) continue;
        long block = (sweep - discarded) * BLOCKS / measured;
        frames++;
        for (int sphere = 0; sphere < SPHERES; sphere++) {
            height[block] += position[sphere][0] / SPHERES;
            int bin = (int)((position[sphere][0] - 0.5) / BIN);
            if (bin < BINS) inside[block][bin] += 1.0;
        }
    }
    double in_block = (double)frames / BLOCKS, mean_height = 0.0, spread = 0.0;
    for (int block = 0; block < BLOCKS; block++) mean_height += (height[block] /= in_block) / BLOCKS;
    for (int block = 0; block < BLOCKS; block++) spread += pow(height[block] - mean_height, 2.0);
    printf("# h_c %.3f, standard deviation of blocks %.3f\n", mean_height, sqrt(spread / (BLOCKS - 1)));
    double away = atof(argument[4]) - mean_height;
    for (int bin = 0; bin < BINS; bin++) {
        double mean = 0.0, product = 0.0, squares = 0.0, density[BLOCKS];
        for (int block = 0; block < BLOCKS; block++) {
            density[block] = inside[block][bin] / (in_block * WIDTH * WIDTH * BIN);
            mean += density[block] / BLOCKS;
        }
        for (int block = 0; block < BLOCKS; block++) product += density[block] * (height[block] - mean_height);
        double slope = product / spread;
        for (int block = 0; block < BLOCKS; block++)
            squares += pow(density[block] - mean - slope * (height[block] - mean_height), 2.0);
        double error = sqrt(squares / (BLOCKS - 2) * (1.0 / BLOCKS + away * away / spread));
        printf("%.1f,%.1f,%.4f,%.4f\n", 0.5 + BIN * bin, 0.6 + BIN * bin, mean + slope * away, error);
    }
    return 0;
}
